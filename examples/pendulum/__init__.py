"""A real pendulum: which friction stops it."""
