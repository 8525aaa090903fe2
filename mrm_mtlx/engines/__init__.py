"""Engines: what compiles, runs or renders generated source here. `base` is the contract, `registry` knows them all."""
