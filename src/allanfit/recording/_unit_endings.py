"""Units at the end of names, as in `wx_dps`: those that mean nothing else there."""

import re

# Not `degs`, `rads` and `m_s_2`: plurals of angles, and the second of several velocities.
_SURE = (
    ("deg/s", r"dps|degps|(?:deg|°)(?:_(?:per_)?|/)s(?:ec)?"),
    ("deg/h", r"dph|(?:deg|°)(?:_(?:per_)?|/)h(?:r|our)?"),
    ("mdps", r"mdps|mdeg/s(?:ec)?"),
    ("rad/s", r"radps|rad(?:_(?:per_)?|/)s(?:ec)?"),
    ("mrad/s", r"mradps|mrad(?:_(?:per_)?|/)s(?:ec)?"),
    ("m/s^2", r"mps2|m_?(?:per_)?s(?:2|\^2|_squared)|m/s(?:\^?2|²|/s)"),
    ("degC", r"deg_?C|celsius"),
    ("counts", r"counts|cts|lsb"),
)
_ENDINGS = tuple(
    (unit, re.compile(rf".*[\W_](?:{ending})", re.IGNORECASE)) for unit, ending in _SURE
)
# A letter or two may mean more; beside what they belong to they do not.
_ACCELERATION = re.compile(r"(?:.*[\W_])?(?:a[xyz]|acc[a-z]*(?:[\W_]*[xyz])?)[\W_]([mu]?g)", re.I)
_TEMPERATURE = re.compile(r"(?:(?:.*[\W_])?[Tt]emp\w*|T)[\W_]([CKF])")


# Of messages of ROS, by the definition of sensor_msgs/Imu.
_ROS = (
    ("rad/s", re.compile(r"(?:.*[./])?angular_velocity[./][xyz]")),
    ("m/s^2", re.compile(r"(?:.*[./])?linear_acceleration[./][xyz]")),
)


def unit_in_name(name: str) -> str:
    """The unit that a name tells, "" where it tells none or where that might be something else."""
    for unit, ending in (*_ENDINGS, *_ROS):
        if ending.fullmatch(name):
            return unit
    if found := _ACCELERATION.fullmatch(name):
        return found[1].lower()
    if found := _TEMPERATURE.fullmatch(name):
        return {"C": "degC", "K": "K", "F": "degF"}[found[1]]
    return ""
