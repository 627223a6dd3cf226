"""Studies: many independent cells, run on any executor and stored one by one."""
