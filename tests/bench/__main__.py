"""Lists the benchmarks, and runs them: python -m tests.bench [NAME ...] [OPTIONS of each]."""

import ast
import runpy
import sys
from pathlib import Path

FOLDER = Path(__file__).parent
START = '__name__ == "__main__"'


def benchmarks() -> dict[str, str]:
    """Name and first sentence of each file here that runs by itself."""
    texts = {path.stem: path.read_text(encoding="utf-8") for path in sorted(FOLDER.glob("*.py"))}
    return {
        name: (ast.get_docstring(ast.parse(text)) or "").partition("\n\n")[0].replace("\n", " ")
        for name, text in texts.items()
        if name != "__main__" and f"if {START}" in text
    }


def main(arguments: list[str]) -> int:
    """Run the named benchmarks one after another, each with the options; without names list all."""
    known = benchmarks()
    first = next((k for k, word in enumerate(arguments) if word not in known), len(arguments))
    names, options = arguments[:first], arguments[first:]
    if not names:
        if options not in ([], ["--help"], ["-h"]):
            print(f"no benchmark {options[0]!r}; there are: {', '.join(known)}", file=sys.stderr)
            return 2
        print("python -m tests.bench NAME [OPTIONS]; NAME --help lists the options")
        for name, says in known.items():
            print(f"  {name:18}{says}")
        return 0
    for name in names:
        sys.argv = [name, *options]
        try:
            runpy.run_module(f"tests.bench.{name}", run_name="__main__", alter_sys=True)
        except SystemExit as end:
            if end.code:
                raise
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
