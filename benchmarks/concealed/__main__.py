"""Conceal, explain, score.

    python -m benchmarks.concealed --quick         # 24 recordings: some minutes
    python -m benchmarks.concealed                 # 1500 recordings, 2 GB of them: hours
    python -m benchmarks.concealed --real          # effects put into real recordings, if present
    python -m benchmarks.concealed --known         # real recordings of which something is known
    python -m benchmarks.concealed --score         # only open the key and score what is there
    python -m benchmarks.concealed --pool A B C    # score sets in these folders as one

Each step goes on where it stopped. The tool is given recordings only; the digest of the answer
key is printed and stored before the first of them is analysed, and checked when it is opened.
"""

import argparse
import json
import platform
import shutil
from importlib.metadata import version
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from . import _key, _known, _real, _score
from ._key import open_key
from ._row import Row
from ._run import run

RESULTS = Path(__file__).parents[1] / "results" / "concealed"


def rows(folder: Path) -> tuple[list[Row], list[str]]:
    """What is so and what was said of every analysed recording; and by which code."""
    found, commits = [], set()
    for truth in open_key(folder):
        file = folder / "results" / f"{truth['recording']}.json"
        if file.exists():
            result = json.loads(file.read_text())
            channels = result.get("explanation", {}).get("channels") or [{}]
            found.append(Row(truth, channels[0], result["seconds"]))
            commits.add(result["commit"])
    return found, sorted(commits)


def main(arguments=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--recordings", type=int)
    parser.add_argument("--seed", type=int, default=1, help="of the set; never one tried before")
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--workers", type=int, default=1)
    tiers = parser.add_mutually_exclusive_group()
    tiers.add_argument("--real", action="store_true", help="the tier of real backgrounds")
    tiers.add_argument("--known", action="store_true", help="the tier of known real recordings")
    parser.add_argument("--conceal", action="store_true", help="only make and seal the set")
    parser.add_argument("--again", action="store_true", help="forget what was said before")
    parser.add_argument("--score", action="store_true", help="only open the key and score")
    parser.add_argument("--pool", type=Path, nargs="+", help="score several sets as one")
    options = parser.parse_args(arguments)
    if options.pool:
        pooled = [row for folder in options.pool for row in rows(folder)[0]]
        print(_score.markdown(_score.score(pooled)))
        return
    count = options.recordings or (24 if options.quick else 1500)
    tier, make, scorer = "synthetic", _key.conceal, _score
    if options.real:
        tier, make, scorer = "real", _real.conceal, _real
    elif options.known:
        tier, make, scorer, count = "known", _known.conceal, _known, len(_known.KNOWN)
    folder = options.folder or RESULTS / f"{tier}-{options.seed}-{count}"
    console = Console(stderr=True)
    if not options.score:
        with Progress(console=console) as bar:
            task = bar.add_task("concealing", total=count)
            digest = make(folder, count, options.seed, options.workers, lambda: bar.advance(task))
            console.print(f"SHA-256 of the answer key: {digest}")
            if options.conceal:
                return
            if options.again:
                shutil.rmtree(folder / "results", ignore_errors=True)
            task = bar.add_task("explaining", total=count)
            run(folder, options.workers, lambda: bar.advance(task))
    found, commits = rows(folder)
    scores = scorer.score(found)
    document = {
        "seal": (folder / "seal.txt").read_text().strip(),
        "commits": commits,
        "machine": platform.platform(),
        "allanfit": version("allanfit"),
        **scores,
    }
    (folder / "scores.json").write_text(json.dumps(document, indent=1) + "\n")
    table = scorer.markdown(scores)
    (folder / "scores.md").write_text(table + "\n")
    print(table)
    if len(commits) > 1:
        console.print(f"Analysed by more than one version: {', '.join(commits)}")


if __name__ == "__main__":
    main()
