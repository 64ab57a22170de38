# Environments

# Finite elements and the network that ships; the figure is copied to docs.
environments() {
    echo '```text'
    tactus bench scenes/tasks/hold.ron --envs 1,4,16,64,256,1024 --model universe --repeat 1 -o "$OUT/environments"
    echo '```'
    cp "$OUT/environments/envs.png" docs/envs.png
}
