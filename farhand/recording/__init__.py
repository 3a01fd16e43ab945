"""What `farhand record` does: the recorder of the site whose configuration it is given."""
