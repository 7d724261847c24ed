"""Whether the noise is as strong at all times: loud times, knocks, vibration."""
