"""The causes that a finding may name, one small class each."""
