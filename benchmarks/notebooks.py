"""Runs the notebooks and keeps each as a light page: `python -m benchmarks.notebooks [NAME ...]`, or `make notebooks`.

A page is plain HTML with its pictures inside, nothing fetched, no scripts; it goes into notebooks/html. Of cells tagged
"prose", which write sentences with the numbers just measured, it shows the sentences and not the code.
"""

from __future__ import annotations

import argparse
import re
import time
from pathlib import Path

import nbformat
from nbconvert import HTMLExporter
from nbconvert.preprocessors import ExecutePreprocessor, TagRemovePreprocessor

FOLDER = Path(__file__).parents[1] / "notebooks"
STYLE = """body{font:16px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;color:#1c2530}
pre{overflow-x:auto;background:#f4f6f8;padding:.6rem .8rem;border-radius:4px;font-size:.85em}
img{max-width:100%}table{border-collapse:collapse}td,th{border:1px solid #d5dbe1;padding:.2rem .5rem;text-align:right}
.prompt,.jp-InputPrompt,.jp-OutputPrompt,.anchor-link{display:none}"""


def page(path: Path) -> str:
    """A notebook, run from its own folder, as HTML."""
    notebook = nbformat.read(path, as_version=4)
    ExecutePreprocessor(timeout=180).preprocess(notebook, {"metadata": {"path": str(path.parent)}})
    exporter = HTMLExporter(template_name="basic")
    exporter.register_preprocessor(TagRemovePreprocessor(remove_input_tags={"prose"}, enabled=True), enabled=True)
    body, _ = exporter.from_notebook_node(notebook)
    body = re.sub(r"<script.*?</script>", "", body, flags=re.DOTALL)
    title = path.stem.replace("_", " ")
    head = f'<meta charset="utf-8"><title>{title}</title><style>{STYLE}</style>'
    return f'<!DOCTYPE html><html lang="en"><head>{head}</head><body>{body}</body></html>\n'


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("names", nargs="*", help="notebooks without their ending; default all")
    chosen = arguments.parse_args().names
    (FOLDER / "html").mkdir(exist_ok=True)
    for path in sorted(FOLDER.glob("*.ipynb")):
        if not chosen or path.stem in chosen:
            begin = time.perf_counter()
            text = page(path)
            target = FOLDER / "html" / f"{path.stem}.html"
            target.write_text(text, encoding="utf-8")
            print(f"{target.relative_to(FOLDER.parent)}: {time.perf_counter() - begin:.0f} s, {len(text) // 1000} kB")


if __name__ == "__main__":
    main()
