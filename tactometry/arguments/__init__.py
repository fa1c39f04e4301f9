"""Checks of arguments, and the error message for each: one vocabulary, each term in one place.

- `constraints` names constraints as data: `Positive`, `NotNegative`, `Share`, `Rate`, or any `Annotated` with the
  classes of `annotated_types`.
- `constrained` (a decorator under `dataclass`) checks the fields of a class against them. `config.strict` builds such a
  class from a file, after it has checked keys and types, so that a file and a call get the same error.
- `checked` (a decorator) checks the arguments of functions and classes by their annotations: kind, finiteness, the
  domain of the unit, and the constraint. Use it for the public API of `stimuli`, called with arrays and numbers.
- `require` has a function for each rule that no annotation states: `one_of`, `lookup`, `some`, `ascending`, ...
  `require.expect` checks a rule of one place, such as `low < high`; write a rule of two places as a new function.
- Raise an error by hand only if its message has another form.
"""
