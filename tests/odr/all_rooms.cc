// Nothing of its own: what matters is what is linked to it.
int main() {}
