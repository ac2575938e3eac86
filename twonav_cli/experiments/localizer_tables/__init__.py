"""Table 3, Table 4 and Fig. 7: every network that the paper printed, trained and measured again."""
