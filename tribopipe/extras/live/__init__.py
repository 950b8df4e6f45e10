"""A test that is still running, followed: k_D so far, the wear at the planned end, and an early word of what is amiss.

`follow` reads what the instrument has appended, `state` condenses it, `estimate` fits it, `law_watch` states when the
wear law stops holding and `mishaps` what else went wrong; `session` puts them together.
"""
