//! From a scene to the bytes that the page draws.
