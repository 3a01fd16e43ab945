"""Films of a bare arm in ordinary rooms, in colour, with exact truth: what the learned tracker is measured on."""
