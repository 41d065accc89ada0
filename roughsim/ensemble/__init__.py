"""Ensembles: many realizations of one scene, in this process or several, into a folder."""
