"""Ten minutes of simulated time with everything going wrong."""
