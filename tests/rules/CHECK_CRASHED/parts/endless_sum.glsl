#define TEN(x) x + x + x + x + x + x + x + x + x + x

void dust(float x, out float result)
{
    result = TEN(TEN(TEN(TEN(TEN(x)))));
}
