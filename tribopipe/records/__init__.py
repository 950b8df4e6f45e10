"""Documents: what people write (manifest, recipe, plan) and what the stages return (results)."""
