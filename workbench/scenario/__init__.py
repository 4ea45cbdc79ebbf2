"""The numbers of a flight: scenario files, the parameter table, excitations."""
