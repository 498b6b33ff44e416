"""One self-contained page with all of a study, and the overlay videos that go with it."""
