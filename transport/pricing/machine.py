"""Name of the machine on which times were measured."""

import os
import platform


def machine_name() -> str:
    """Processor, number of cores and system, such as "AMD EPYC, 2 cores, Linux x86_64"."""
    cores = os.cpu_count() or 1
    return f"{_processor()}, {cores} core{'s' if cores > 1 else ''}, {platform.system()} {platform.machine()}"


def _processor() -> str:
    """Name of the processor."""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    except OSError:
        names = []
    return next(iter(names), "") or platform.processor() or "unknown processor"
