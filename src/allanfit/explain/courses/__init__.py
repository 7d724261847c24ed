"""What is a course in time and no noise: steps, warm-ups, slow swings, temperature."""
