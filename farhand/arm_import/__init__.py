"""An arm's URDF as its maker publishes it, made into a configuration that runs."""
