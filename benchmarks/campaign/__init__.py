"""Many runs of one method: 160 abstract tests with 41 seeds each, as in the follow-up study of the original."""
