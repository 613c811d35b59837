"""The report of a study: templates with all sentences, and their rendering as HTML, PDF and text."""
