"""From hand sample to joint motion: validation, mapping, the pipeline; pure."""
