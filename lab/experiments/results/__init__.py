"""Every table and figure of both sources beside ours, from the reports of all experiments."""
