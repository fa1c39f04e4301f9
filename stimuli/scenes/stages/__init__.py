"""What the stages call: callables and a-priori errors that several effects or surfaces share."""
