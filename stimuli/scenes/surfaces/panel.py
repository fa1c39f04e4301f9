"""What holds of an electrode under a finger as long as no effect of the slot says otherwise."""

from collections.abc import Mapping

ASSUMES: Mapping[str, str] = {
    "body": "no resistance of body and source",
    "leakage": "a corneum without losses",
    "gap": "no air between insulator and skin",
    "area": "a contact area that no force changes",
    "polarity": "the same attraction at either sign of the voltage",
}
