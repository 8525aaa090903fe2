void dust(float x, out float result)
{
    result = 1.0 - x;
}
