"""Placing the thesis's block through pixels: trials in lockstep, their figures and their report."""
