"""Mutation testing: small bugs are planted one at a time, and the tests must notice each.

Source: DeMillo, Lipton and Sayward 1978, Computer 11(4) (a suite is as good as the share of
mutants that it kills).
"""
