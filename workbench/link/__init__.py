"""The wire protocol, its server and its clients; neither Drake nor Qt is needed here."""
