"""The command `farhand record`: the recorder of the site whose configuration it is given."""
