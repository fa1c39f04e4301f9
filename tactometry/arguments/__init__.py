"""Checks of arguments and their error messages.

- `constraints` names constraints as data: `Positive`, `NotNegative`, `Share`, `Rate`, or any `Annotated` with the
  classes of `annotated_types`.
- `constrained` (a decorator under `dataclass`) checks the fields of a class against them. `config.strict` builds such a
  class from a file, after it has checked keys and types, so that a file and a call get the same error.
- `checked` (a decorator) checks the arguments of functions and classes by their annotations: kind, finiteness, the
  domain of the unit, and the constraint. Use it for the public API of `stimuli`, called with arrays and numbers.
- `require` has a function for each rule that annotations cannot state: `one_of`, `lookup`, `some`, `ascending`, ...
  `require.expect` checks a rule used once, such as `low < high`; write a new function for a rule used twice.
- Raise other errors directly only if the message has another form.
"""
