"""Design of screens: closed forms, the guide and the choice of glass."""
