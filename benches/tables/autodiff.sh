# Layers of a training step: dfdx's and our own on its tape

# Forward and backward on one thread, for a graph of 1,500 nodes and 12,000 edges with 48 values each.
autodiff() {
    RAYON_NUM_THREADS=1 cargo bench --bench autodiff 2> /dev/null
}
