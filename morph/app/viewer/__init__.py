"""The viewer: bodies side by side in the browser, on one clock."""
