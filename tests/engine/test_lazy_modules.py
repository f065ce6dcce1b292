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


def test_an_attribute_set_before_a_module_is_loaded_stays(monkeypatch):
    name = "transport.engine.passes.mis"
    monkeypatch.setitem(sys.modules, name, sys.modules[name])
    module = registry._lazy_module(registry.FOLDER / "mis.py")
    module.record_pdf_at_walls = "planted"
    assert (
        module.record_pdf_at_walls == "planted"
        and module.record_pdf_at_collisions.name == "record_pdf_at_collisions"
    )
