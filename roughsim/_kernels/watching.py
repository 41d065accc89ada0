"""Watching for a word from another thread, in a loop of the processor: a thread that sleeps takes 50 µs to wake."""

from typing import Any

import numpy as np
from numba import config, types
from numba.extending import intrinsic

from roughsim._kernels import kernel


def _latest(context: Any, words: Any, i: Any) -> Any:
    """Load a word from memory each time it is asked for: the compiler may not keep it."""

    def load(compiler: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        array = compiler.make_array(signature.args[0])(compiler, builder, arguments[0])
        return builder.load_atomic(builder.gep(array.data, [arguments[1]]), "seq_cst", 8)

    return types.int64(words, types.intp), load


latest: Any = (lambda words, i: words[i]) if config.DISABLE_JIT else intrinsic(_latest)  # type: ignore[attr-defined]
TURNS = 0 if config.DISABLE_JIT else 500_000  # type: ignore[attr-defined]  # of the loop, about half a millisecond


@kernel()
def watch(words: Any, own: int, word: int, other: int, old: int, turns: int) -> bool:
    """Say `word` at the place `own`, then watch the place `other`: whether its word changes from `old` in time.

    `words` are int64 and contiguous. Each thread has one place to say something.
    """
    words[own] = np.int64(word)  # said here, where no GIL is held: who hears it can go on at once
    while turns > 0 and latest(words, other) == old:
        turns -= 1
    return turns > 0
