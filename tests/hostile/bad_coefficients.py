"""Files of coefficients that must be refused, and what has to be said."""

import json

_LAUGHS = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]\n" for k in range(1, 12)
)
_LAUGHS_AS_VALUE = "N: &a0 [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{symbol}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]\n"
    for k, symbol in enumerate("QBKR", start=1)
)


def fit_document(*names: str, **changes: object) -> dict[str, object]:
    """A fit of channels with these names, each changed."""
    term = {"name": "n", "unit": "deg/s", "value": 1e-3, "resolved": True, "upper_limit_95": 1e-3}
    channels = [
        {
            "channel": name,
            "unit": "m/s^2" if name.startswith("acc") else "deg/s",
            "rate_hz": 100.0,
            "samples": 1000,
            "coefficients": {s: {**term, "intervals": {"0.95": [0, 1]}} for s in "QNBKR"},
            **changes,
        }
        for name in names
    ]
    return {"schema": "allanfit.fit/1", "recording": "r", "channels": channels}


def _fit(**changes: object) -> str:
    return json.dumps(fit_document("gyro_x", **changes))


#: What stands in the file, and a pattern of the sentence.
BAD = {
    "effects that are no list": (
        "unit: deg/s\nN: 5.0e-3\neffects:\n  sinusoid: {amplitude: 1, frequency: 2}\n",
        "An effect in .* needs its name and parameters",
    ),
    "empty": ("", "is empty"),
    "junk": (bytes(range(256)) * 9, "not text|neither JSON nor YAML"),
    "utf-16": ("N: 1\n".encode("utf-16"), "not text|neither JSON nor YAML"),
    "a number": ("5\n", "holds no coefficients"),
    "a list": ("[1, 2]\n", "holds no coefficients"),
    "two documents": ("N: 1\n---\nN: 2\n", "neither JSON nor YAML"),
    "tabs": ("N:\t1\n\tB: 2\n", "begin with tabs"),
    "a billion laughs": (_LAUGHS, "without anchors"),
    "laughs as a value": (_LAUGHS_AS_VALUE, "without anchors"),
    "deep lists": ("[" * 100_000, "nested|neither"),
    "deep mappings": ('{"a":' * 100_000, "nested|neither"),
    "deep and whole": ("N: " + "[" * 5000 + "]" * 5000, "nested|neither|must be a number"),
    "a list in itself": ("N: &a [*a]\n", "without anchors"),
    "code": ("!!python/object/apply:os.mkdir [ran]\n", "neither JSON nor YAML"),
    "code as a value": ("N: !!python/object/apply:os.mkdir [ran]\n", "neither JSON nor YAML"),
    "keys twice": ("N: 1\nN: 2\n", "twice"),
    "keys twice in JSON": ('{"N": 1, "B": 1, "N": 2}', "twice"),
    "keys that are lists": ("[1, 2]: 3\n", "neither|names"),
    "keys that are numbers": ("1: 3\n", "names '1'"),
    "keys with control characters": ('{"\\u001b[31mN\\n": 1}', "names"),
    "NaN in JSON": ('{"N": NaN}', "must be a number, zero or more"),
    "Infinity in JSON": ('{"N": Infinity}', "must be a number, zero or more"),
    "nan": ("N: .nan\n", "must be a number, zero or more"),
    "inf": ("N: .inf\n", "must be a number, zero or more"),
    "negative": ("N: -1\n", "must be a number, zero or more"),
    "words": ("N: small\n", "must be a number, zero or more"),
    "truth": ("N: true\n", "must be a number, zero or more"),
    "nothing": ("N:\n", "must be a number, zero or more"),
    "a date": ("N: 2024-01-01\n", "must be a number, zero or more"),
    "decimal commas": ("N: 0,005\n", "must be a number, zero or more"),
    "500 digits": ("N: " + "9" * 500 + "\n", "must be a number"),
    "50000 digits": ("N: " + "9" * 50_000 + "\n", "neither|must be a number"),
    "1e400": ("N: 1.0e+400\n", "must be a number, zero or more"),
    "a huge coefficient": ("N: 1.0e+300\n", "N in .* sensor|1e[+]100"),
    "a date that is none": ("N: 2024-99-99\n", "neither|must be a number"),
    "a sampling in a list": ("N: 1\nsampling: [point]\n", "point or averaged"),
    "an unknown unit": ("N: 1\nunit: 9**9**9\n", "is not known"),
    "a unit that is a list": ("N: 1\nunit: [deg, s]\n", "is not known|unit"),
    "an effect of no name": ("N: 1\neffects: [{amplitude: 1}]\n", "needs its name"),
    "an unknown effect": ("N: 1\neffects: [{name: gremlins}]\n", "gremlins"),
    "an effect of a long name": (
        f"N: 1\neffects: [{{name: {3000 * 'x'}}}]\n",
        "[^ ]{10,60} is not known",
    ),
    "effects that are a number": ("N: 1\neffects: 5\n", "needs its name"),
    "an effect of NaN": (
        "N: 1\neffects: [{name: sinusoid, amplitude: .nan, frequency: 1}]\n", "amplitude"
    ),
    "an effect of words": (
        "N: 1\neffects: [{name: sinusoid, amplitude: much, frequency: 1}]\n", "amplitude|number"
    ),
    "no channels": ('{"channels": []}', "not a complete fit JSON"),
    "channels of nothing": ('{"channels": [null]}', "not a complete fit JSON"),
    "coefficients of nothing": (_fit(coefficients=None), "not a complete fit JSON"),
    "coefficients in a list": (_fit(coefficients=[1, 2]), "not a complete fit JSON"),
    "a mean in words": (_fit(mean="much"), "not a complete fit JSON"),
    "a mean of NaN": (_fit(mean=float("nan")), "not a complete fit JSON"),
    "a name that is a list": (_fit(channel=["x"]), "not a complete fit JSON"),
    "a sampling of its own": (_fit(sampling="often"), "not a complete fit JSON|point or averaged"),
}  # fmt: skip
