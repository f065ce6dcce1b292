"""Files of passes are read by one thread, once; others that look at the same moment wait until it is done."""

import sys
from threading import Barrier, Thread

from transport.engine import registry

SLOW = """
import time
ready = False
time.sleep(0.05)
ready = True
"""


def test_threads_that_load_a_module_at_once_wait_until_it_is_complete(tmp_path, monkeypatch):
    """As users' threads do that each begin a run: seven of eight raised "has no attribute 'begin'"."""
    file = tmp_path / "slow_family.py"
    file.write_text(SLOW, encoding="utf-8")
    monkeypatch.setitem(sys.modules, "transport.engine.passes.slow_family", None)
    module, at_once, seen = registry._lazy_module(file), Barrier(4), []
    assert type(module) is registry.LazyModule

    def look():
        at_once.wait()
        seen.append(getattr(module, "ready", None))

    threads = [Thread(target=look) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert seen == [True] * 4
    assert type(module).__name__ == "module"
