"""The page in a real browser, from the command's own server."""

import json
import re
import shutil
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest
from process_cases import begin_process

import roughsim as rs

pytest.importorskip("bokeh")


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


@pytest.fixture
def served(capped_run):
    """The secret address of a page served by the command."""
    port = free_port()
    command = [
        sys.executable,
        "-m",
        "roughsim",
        "explore",
        str(capped_run.folder),
        "--no-browser",
    ]
    root = str(Path(rs.__file__).parents[1])
    server = begin_process(
        [*command, "--port", str(port)], stderr=subprocess.PIPE, text=True, cwd=root
    )
    told = server.stderr.readline()
    told = re.fullmatch(
        rf"page: (http://127\.0\.0\.1:{port}/[\w-]+/) \(this computer only; Ctrl-C ends it\)\n",
        told,
    )
    yield told[1]
    server.terminate()
    server.wait(10)
    server.stderr.close()


@pytest.mark.slow
def test_the_server_listens_on_this_computer_only(served, capped_run, capsys):
    port = int(served.split(":")[2].split("/")[0])
    own = {info[4][0] for info in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)}
    for address in own - {"127.0.0.1"}:
        if not address.startswith("127."):
            with pytest.raises(OSError, match="refused|unreachable|timed out"):
                socket.create_connection((address, port), timeout=1).close()
    from roughsim.cli import main

    with pytest.raises(SystemExit):
        main(["explore", str(capped_run.folder), "--no-browser", "--port", str(port)])
    assert "not free on 127.0.0.1; choose another with --port" in capsys.readouterr().err


def chromium():
    return next(
        filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
    )


@pytest.mark.slow
def test_in_a_browser(served):
    driver = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if chromium() is None:
        pytest.skip("no Chromium on this computer")
    with driver.sync_playwright() as tools:
        options = {"executable_path": chromium(), "args": ["--no-sandbox", "--disable-gpu"]}
        browser = tools.chromium.launch(**options)
        try:
            look_at(browser.new_page(viewport={"width": 1366, "height": 1200}), served)
        finally:
            browser.close()


STATE = """() => {
  const find = name => Bokeh.documents[0].get_model_by_name(name);
  const image = name => find(name).renderers.find(r => r.glyph.type === 'Image').data_source.data;
  const sum = name => Array.from(image(name).image[0] ?? []).reduce((a, b) => a + b, 0);
  const ends = name => [find(name).x_range.start, find(name).x_range.end];
  return {title: find('temperature').title.text, sum: sum('temperature'), width: image('heights').dw[0],
          ends: ['heights', 'pressure', 'temperature'].map(ends), values: find('values').text,
          angle: find('angle').value, problems: find('problems').text, speed: find('speed_box').value,
          widths: ['heights', 'pressure', 'temperature'].map(name => find(name).inner_width)}
}"""


def until(tab, condition):
    for _ in range(100):
        state = tab.evaluate(STATE)
        if condition(state):
            return state
        time.sleep(0.1)
    raise AssertionError(json.dumps(state))


def look_at(tab, address):
    """It loads; sliders, zoom and clicks do their work; no error, and no request to anywhere else."""
    errors, requests = [], []
    tab.on(
        "console", lambda message: errors.append(message.text) if message.type == "error" else None
    )
    tab.on("pageerror", lambda error: errors.append(str(error)))
    tab.on("request", lambda request: requests.append(request.url))
    tab.set_default_timeout(20_000)
    tab.goto(address)
    tab.wait_for_function(
        "window.Bokeh?.documents[0]?.get_model_by_name('temperature')?.title?.text.includes('m/s')"
    )
    first = until(tab, lambda state: state["sum"] > 0 and state["values"])
    handle = tab.locator(".noUi-handle").first
    handle.focus()
    for _ in range(20):
        tab.keyboard.press("ArrowLeft")  # half a decade slower
    moved = until(tab, lambda state: state["speed"] != first["speed"] and "m/s" in state["title"])
    assert moved["sum"] != first["sum"]
    box = tab.locator(".bk-Figure").first.bounding_box()
    tab.mouse.move(box["x"] + 200, box["y"] + 200)
    tab.mouse.wheel(0, -600)
    zoomed = until(tab, lambda state: state["width"] < 0.9 * first["width"])
    assert zoomed["ends"][0] == zoomed["ends"][1] == zoomed["ends"][2]
    tab.mouse.click(box["x"] + 260, box["y"] + 240)
    until(tab, lambda state: state["values"] != first["values"])
    tab.locator(".noUi-handle").nth(1).focus()
    for _ in range(3):
        tab.keyboard.press("ArrowRight")
    turned = until(tab, lambda state: state["angle"] == 3 and "m/s" in state["title"])
    assert turned["problems"] == ""
    tab.set_viewport_size({"width": 900, "height": 1200})  # two maps in a line, one in the next
    until(tab, lambda state: state["widths"] == [254, 254, 254])
    assert errors == []
    assert [url for url in requests if not url.startswith((address, "data:", "blob:"))] == []
