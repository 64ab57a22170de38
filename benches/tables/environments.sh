# Environments

# Finite elements and the network of the tasks, which is trained as in docs/rl.md; the figure is copied to docs.
environments() {
    local model=out/tasks_model
    if [ ! -d $model ]; then
        tactus dataset scenes/tasks/data.ron -o out/tasks > /dev/null || [ $? -eq 1 ]
        tactus train out/tasks --model models/small.ron -o $model > /dev/null
    fi
    echo '```text'
    tactus bench scenes/tasks/hold.ron --envs 1,4,16,64,256,1024 --model $model --repeat 1 -o "$OUT/environments"
    echo '```'
    cp "$OUT/environments/envs.png" docs/envs.png
}
