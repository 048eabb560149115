"""Read and write robot files: rigid bodies, friction laws, drives and sensors in one object."""
