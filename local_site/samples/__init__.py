"""From arm estimate to hand sample: smoothing, gesture, intent, publishing."""
