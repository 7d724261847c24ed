"""What values and time stamps tell by themselves: codes, copies, rails, spikes, clocks."""
