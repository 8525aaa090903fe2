void dust(float x, out float result)
{
    result = x;
    for (int i = 0; i < 2; ++i)
        for (int j = 0; j < 2; ++j)
        {
            result = sin(result + 1.0);
        }
}
