"""Builds the report with the Python package `typst`: python3 paper/build.py [OUT.pdf]

Nothing else is read than the folders `paper` and `results`, CITATION.cff, one picture of the book and the typeface of the figures; no network,
no system font.
"""

import sys
from pathlib import Path

try:
    import typst
except ImportError:
    sys.exit("error: the Python package of Typst is missing: pip install typst")

root = Path(__file__).resolve().parent.parent
out = Path(sys.argv[1]) if len(sys.argv) > 1 else root / "results" / "paper" / "paper.pdf"
out.parent.mkdir(parents=True, exist_ok=True)
try:
    typst.compile(
        root / "paper" / "paper.typ",
        output=out,
        root=root,
        font_paths=[root / "crates" / "presentation" / "rimbench-figures" / "src" / "font"],
        ignore_system_fonts=True,
        pdf_standards=["ua-1"],
    )
except typst.TypstError as error:
    sys.exit(error.diagnostic)
print(out)
