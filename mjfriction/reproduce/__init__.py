"""The source documents' experiments on simulated machines, our figures beside the printed ones."""
