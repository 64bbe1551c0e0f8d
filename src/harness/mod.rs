//! Laws, verdicts, campaigns and order estimates: generic over the case, without any Lie theory.
