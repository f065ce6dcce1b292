"""A fault: what is written in the place of what, and which tests are to see it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LIBRARY = "transport"
COMPILED = ("engine/", "physics/", "compile/layout.py")  # of which machine code is made


@dataclass(frozen=True)
class Fault:
    """One change of one file of the library.

    file: within transport/, or of an experiment, as "sims/sun.py";  old: a piece of its text that occurs once there;  new: what takes its place;  what: what is wrong
    then, in words;  tests: where a developer would look, as "physics/test_rays" or "hard/test_hard_points::test_detours_follow_their_law".
    """

    file: str
    old: str
    new: str
    what: str
    tests: tuple[str, ...]

    @property
    def path(self) -> str:
        """The file, from the root of a copy on, where sims are a part of the package."""
        return f"{LIBRARY}/{self.file}"

    @property
    def source(self) -> Path:
        """The file in the project."""
        return ROOT / (self.file if self.file.startswith("sims/") else self.path)

    @property
    def nodes(self) -> list[str]:
        """The tests as pytest wants them."""
        names = (test.partition("::") for test in self.tests)
        return [f"tests/{file}.py{colons}{name}" for file, colons, name in names]

    @property
    def is_compiled(self) -> bool:
        """Whether machine code changes with it."""
        return self.file.startswith(COMPILED)

    def planted(self, text: str) -> str:
        """The file's text with the fault in it.  Raises ValueError where that cannot be."""
        if (found := text.count(self.old)) != 1:
            raise ValueError(
                f"{self.path}: must hold the text of {self.what!r} once, got {found}: {self.old!r}"
            )
        changed = text.replace(self.old, self.new)
        compile(changed, self.path, "exec")
        return changed
