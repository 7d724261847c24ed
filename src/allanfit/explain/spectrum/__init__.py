"""The structure that a spectrum asks for: ordinates, bins of them, fits of terms and effects."""
