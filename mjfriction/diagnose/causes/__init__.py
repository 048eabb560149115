"""The causes a finding may carry, one small class each."""
