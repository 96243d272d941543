"""Pictures: the self-contained HTML report and figures for papers. Reads results, never calls a planner."""
