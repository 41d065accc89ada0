"""The picture of docs/explore.md: python docs/screenshot.py RUN [CHROMIUM]

Opens the page of `roughsim explore RUN` in the browser of `pip install playwright && playwright install chromium`, or
in another Chromium by the path of its program, and takes its upper part as docs/figures/explore.png.
"""

import re
import subprocess
import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

SIZE = {"width": 960, "height": 1340}  # three maps in a line; without the text at the end
SECONDS = 5.0  # until all fields have come


def take(run: str, chromium: str | None) -> None:
    """Start the server, photograph its page, and end it."""
    command = ["roughsim", "explore", run, "--no-browser"]
    with (
        subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as server,
        sync_playwright() as playwright,
    ):
        assert server.stderr is not None
        address = re.search(r"http\S+", server.stderr.readline())
        if address is None:
            raise RuntimeError(f"`{' '.join(command)}` gave no address")
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        page = browser.new_page(viewport=SIZE)
        page.goto(address.group())
        page.wait_for_timeout(1e3 * SECONDS)
        page.screenshot(path=Path(__file__).parent / "figures" / "explore.png")
        browser.close()
        server.terminate()


if __name__ == "__main__":
    take(sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else None)
