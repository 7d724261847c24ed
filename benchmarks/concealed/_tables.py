"""Scores as the tables that the docs quote."""


def markdown(scores: dict) -> str:
    """The tables that the docs quote."""
    verdict = {True: "yes", False: "**no**", None: ""}
    lines = ["| figure | found | 95 % bar | of | target | met |", "|---|---|---|---|---|---|"]
    for f in scores["figures"]:
        if f["total"]:
            low, high = f["bar_95"]
            lines.append(
                f"| {f['name']} | {f['share']:.3f} | {low:.3f} to {high:.3f} | {f['total']} "
                f"| {f['target']} | {verdict[f['met']]} |"
            )
    for n in scores["numbers"]:
        if n["of"]:
            lines.append(
                f"| {n['name']} | {n['value']:.3g} | | {n['of']} | {n['target']} "
                f"| {verdict[n['met']]} |"
            )
    lines += ["", "Found / rightly named / of, by cause and lambda:", ""]
    for name, cells in sorted(scores["power"].items()):
        each = (f"{s}: {a}/{b}/{c}" for s, (a, b, c) in sorted(cells.items(), key=_by_strength))
        lines.append(f"- {name}: {', '.join(each)}")
    lines += ["", *confusion_table(scores["confusion"]), "", "Failures, with their lambda:", ""]
    lines += [
        f"- {f['recording']} {f['profile']}: {' and '.join(f['truth']) or 'nothing'}; "
        f"{f['verdict']} {', '.join(f['named'])}"
        for f in scores["failures"]
    ]
    return "\n".join(lines)


def _by_strength(item):
    return float(item[0])


# Names that share a spectrum, or a place in the values, side by side.
ORDER = (
    ("nothing",),
    ("gauss_markov", "random_telegraph"),
    ("output_rounding", "outliers"),
    ("sinusoid", "drifting_line", "resonance"),
    ("low_pass", "sample_hold"),
    ("power_law", "temperature", "warm_up", "step"),
    ("variance_modulation", "vibration_rectification", "disturbance"),
    ("dropped_samples", "saturation"),
)


def confusion_table(table: dict) -> list[str]:
    """Truth (rows) by name given (columns); names in one box are bracketed by position."""
    order = [name for box in ORDER for name in box]
    rows = sorted(table, key=lambda n: (order.index(n) if n in order else len(order), n))
    given = {name for counts in table.values() for name in counts}
    columns = sorted(given, key=lambda n: (order.index(n) if n in order else len(order), n))
    box = {name: number for number, names in enumerate(ORDER) for name in names}
    lines = ["| truth \\ named | " + " | ".join(columns) + " |", "|---" * (len(columns) + 1) + "|"]
    for true in rows:
        cells = []
        for name in columns:
            count = table[true].get(name, 0)
            same = true in box and box.get(name) == box[true]
            cells.append(f"[{count}]" if same else str(count or ""))
        lines.append(f"| {true} | " + " | ".join(cells) + " |")
    return lines
