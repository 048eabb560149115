"""The source documents' experiments on simulated machines, our numbers beside the printed ones."""
